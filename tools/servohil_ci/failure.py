"""What goes wrong for a user, told in one line."""

OK, INVALID, USAGE, NOTHING = 0, 1, 2, 3  # exit statuses of servohil and its tools: NOTHING: the machine lacks something


class Failure(Exception):
    """Ends a program with this exit status, or fails a test: names the file, place or value, and what would be right."""

    def __init__(self, status, text):
        super().__init__(text)
        self.status = status
