"""Fits of one data set: stripes, IDA, cloud, ordered states, systems."""
