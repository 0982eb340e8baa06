"""How compiled code is made."""
