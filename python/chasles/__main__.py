"""`python -m chasles` is the command `chasles`."""

from ._functions import main

if __name__ == "__main__":
    main()
