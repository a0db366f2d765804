"""``python -m rogue``: the same as the ``rogue`` command."""

from rogue.cli import main

if __name__ == "__main__":
    main()
