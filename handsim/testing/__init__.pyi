from .assertion import assert_as_baseline as assert_as_baseline
