"""Points that cameras saw on a hand, as files hold them: names, orders, units, times and gaps.

In: files of keypoints or markers. Out: points over time in metres, and which part of the hand each
is. What angles they mean is found in `recordings.fitting`. Imports only what that room does.
"""
