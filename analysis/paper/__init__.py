"""What concerns the paper alone: its figures, numbers and findings beside ours, and the page that shows them."""
