"""The world as a Gymnasium, PettingZoo or Stable-Baselines3 environment."""
