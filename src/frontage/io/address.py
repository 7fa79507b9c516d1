"""Addresses, as city models keep them: number and street."""


def split_address(address: str) -> tuple[str, str]:
    """Number ("" where there is none) and street of an address, the number first or last."""
    words = address.split()
    if len(words) > 1 and words[0][0].isdigit():
        return words[0], " ".join(words[1:])
    if len(words) > 1 and words[-1][0].isdigit():
        return words[-1], " ".join(words[:-1])
    return "", address
