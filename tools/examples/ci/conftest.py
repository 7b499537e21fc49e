pytest_plugins = ["servohil_ci.plugin"]
