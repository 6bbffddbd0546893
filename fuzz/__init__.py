"""Random and hostile input for all code that reads data from peers, boards and files; see fuzz/README.md."""
