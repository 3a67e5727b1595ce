"""What every test shares."""

from hypothesis import settings

# The first call of a kernel compiles it, so a deadline would measure the compiler. Runs are derandomized: a
# change is judged by the same examples everywhere.
settings.register_profile("house", deadline=None, derandomize=True, print_blob=True)
settings.load_profile("house")
