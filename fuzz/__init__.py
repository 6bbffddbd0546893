"""Random and hostile input for everything that strangers, boards and files bring; see fuzz/README.md."""
