"""Who evaluates: each backend brings workers, and all of them stand behind the one contract of `contract.py`."""
