"""What a run keeps on disk to go on from: checkpoints, its history, the lock of its directory."""
