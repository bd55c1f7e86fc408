"""model.toml: which effects the model holds, added and removed with the user's comments kept."""
