"""The viewer: a policy in a window, or saved as a video or a picture."""
