"""Sensors: terrestrial scanners, a mobile mapping vehicle and cameras, with their noise and pose errors.

`terrestrial.scan_stations`, `mobile.drive` and `photograph.iter_photographs` are the entry functions. They
return the library's own nouns (`Scan`, `Photo`) together with the truth about every point and pose.
"""
