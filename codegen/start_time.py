"""The time at which this process began to load the package."""

import time

#: Source files that are younger than this are not those that the process runs. In seconds since the epoch.
LOADED = time.time()
