"""Where the model of small deflections ends: measured against the exact beam."""
