"""`python -m chasles` is the command `chasles`."""

from ._functions import main

main()
