from .registration import *  # noqa: F403
