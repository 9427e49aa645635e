"""Flying a comparison: the experiment, the engines that fly it, its episodes, and the stored results."""
