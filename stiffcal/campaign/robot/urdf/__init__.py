"""What a URDF holds: a tree of links, of which the chain from base to tip is a part."""
