"""Tables of displacements under load, judged by what joint springs explain of them."""
