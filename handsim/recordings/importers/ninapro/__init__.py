"""The layout ``ninapro``: MATLAB files of the Ninapro databases, one recording a repetition.

Layout, as the instructions of the databases at ninapro.hevs.ch state it: a file for each subject
and exercise, with synchronised variables of n rows.

- ``glove``: 22 columns, uncalibrated values of a CyberGlove II, in the maker's order, which is that
  of `handsim.joints.JOINTS` (DB1, DB2, DB3, DB4, DB5, DB7, DB9). They are counts: a calibration is
  needed. 18 columns without DIP: the glove of DB8 and DB6, calibrated to degrees in DB8 (say
  ``--units deg``).
- ``angles``: 22 columns [deg], calibrated (DB9 only); taken where it is there and no calibration is
  given. Sensor 11, the abduction of the index finger, was left out by the authors.
- ``restimulus``: label of the movement, corrected afterwards; 0 is rest. ``stimulus``, what was
  shown, is taken where it is missing.
- ``rerepetition``: number of the repetition; ``repetition`` where it is missing. Without any, the
  runs of a movement are counted.
- ``emg``: kept as channels emg_01, emg_02 and so on.
- ``acc``, ``inclin``: kept as channels acc_01 and so on, inclin_01, inclin_02.
- ``subject``, ``exercise``: numbers; from a name such as S1_E2_A1.mat where they are missing.

The sign of counts is the calibration's. Angles are taken as they are, with flexion positive, as in
DB9; the signs of its abductions and of its wrist have not been compared with a recording, and the
notes of the recordings say so.

A recording is a run of one movement and one repetition. It starts up to `REST_BEFORE` before the
label does, at rest, so that it has a start, and ends with the label. Its task is ``movement-05``,
with the further columns movement, repetition and exercise.

The files do not state rates, but for a variable ``frequency`` in some. By the databases: 10
electrodes are DB1's, at 100 Hz; 12 are those of DB2, DB3, DB4 and DB7, at 2000 Hz; 16 with 3
columns of acc are DB5's, at 200 Hz; 14 or 16 with others those of DB6 and DB8, at 2000 Hz. A rate
that is given comes before all of these.
"""
