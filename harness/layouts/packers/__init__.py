"""Plans of packing software as layouts: one module for each packer."""
