"""What people look at: pictures, video, figures."""
