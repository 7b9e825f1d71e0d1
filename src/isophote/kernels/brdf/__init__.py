"""How surfaces scatter light, a file for each kind, called by address; see contract.py."""
