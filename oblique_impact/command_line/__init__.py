"""Words, one typed call, print."""
