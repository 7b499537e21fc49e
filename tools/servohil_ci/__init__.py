"""servohil in tests: a pytest fixture that runs the emulator and speaks to it on CAN.

    PYTHONPATH=tools /usr/bin/python3 -m pytest -p servohil_ci.plugin

plugin: fixture, options, and what an INVALID run does to a test. bench: the fixture's object. emulator: the program's
process. contract: the DBC file. bus: python-can. control: the control socket. Needs Debian's python3-pytest,
python3-can, python3-serial and python3-canmatrix, nothing else.
"""
