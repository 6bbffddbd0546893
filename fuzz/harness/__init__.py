"""One module a target: `run(data)` raises when a promise is broken, `seeds()` are meaningful inputs."""
