"""The places where robots shall be, and when: paths, references, posture errors."""
