"""A campaign's plan: its robot, means and goals, the runs that are chosen, and the files made of them."""
