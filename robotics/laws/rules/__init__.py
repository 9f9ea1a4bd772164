"""Laws whose decisions are rule bases: any one of the user's, or a team's hierarchy of five."""
