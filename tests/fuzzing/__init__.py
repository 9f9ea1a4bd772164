"""Everything that is read, given damaged and hostile versions of good files: what breaks is refused with a sentence."""
