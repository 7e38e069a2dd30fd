"""A robot on a page: driven by hand or by a policy, among people who can be dragged."""
