"""Raw data gloves: counts of their sensors, and the calibration that turns them into angles."""
