"""One module for each target: `run(data)` raises if a promise is broken, `seeds()` are valid inputs."""
