"""Recordings to look at: in the Rerun viewer, as a Rerun file, as a picture.

`life` turns a recording's messages into arrays, `rerun_log` and `picture` show them, `cli` is the command line.
Rerun and matplotlib are imported where they are used: either works without the other.
"""
