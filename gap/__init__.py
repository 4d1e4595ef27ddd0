"""Where a simulator differs from measured runs, which effect causes it, and how far it shrinks."""
