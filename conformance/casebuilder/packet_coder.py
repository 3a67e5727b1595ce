def coded(before, after):
    raise NotImplementedError
