"""`python -m stiffcal`: the same as the `stiffcal` command."""

from stiffcal.cli.app import main

if __name__ == "__main__":
    main()
