"""The studies that fill the tables of docs/ and of this folder: `python3 -m studies.NAME`."""
