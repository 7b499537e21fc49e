"""What goes wrong for a user, told in one line."""

# Exit statuses of servohil and its tools; NOTHING: the machine lacks something.
OK, INVALID, USAGE, NOTHING = 0, 1, 2, 3


class Failure(Exception):
    """Ends a program with this exit status, or fails a test: names file, place or value, and what would be right."""

    def __init__(self, status, text):
        super().__init__(text)
        self.status = status
