"""One picture from many photos: their light brought together, one photo chosen per place, seams blended."""
