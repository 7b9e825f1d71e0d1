"""Checks that a user can run: what Isophote computes against what is known to be exact."""
