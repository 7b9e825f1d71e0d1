"""`python -m isophote`: the command line."""

from isophote.cli.main import main

__all__: list[str] = []

if __name__ == "__main__":
    main()
