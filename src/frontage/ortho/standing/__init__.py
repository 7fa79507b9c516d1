"""What stands free before a facade: trees, cars, lamps, people, signs and wires, each with a box."""
