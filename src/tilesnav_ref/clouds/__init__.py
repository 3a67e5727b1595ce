"""Point clouds: readers and made-up towns."""
