"""python-can and canmatrix, imported without the noise that is not about the user's test."""

import logging
import warnings

logging.getLogger("canmatrix").setLevel(logging.CRITICAL)  # "xlsx is not supported"
with warnings.catch_warnings():
    warnings.simplefilter("ignore")  # what their authors are to change
    import can
    import canmatrix.formats

__all__ = ["can", "canmatrix"]
