"""``python -m tca_bus``: the same as the ``tca`` command."""

from tca_bus.cli.tca import main

__all__ = ["main"]

if __name__ == "__main__":
    main()
