"""What people look at: pictures, films, reports and the designer's panels."""
