"""GTSRB class folders: each sign cut out of each of its frames, with a border, and a table a class.

::

    00014/00003_00007.ppm     class 14, track 3, its 8th picture in time
    00014/GT-00014.csv        Filename;Width;Height;Roi.X1;Roi.Y1;Roi.X2;Roi.Y2;ClassId
    crops.csv                 where each crop was cut out, and of which track

The border is 10 % of the sign, at least 5 px. Outside of the picture it repeats the last pixels. ``X2`` and ``Y2`` are
exclusive. Source: Readme of the benchmark (Stallkamp et al. 2012). The benchmark's own folders do not say
where a crop was cut out; the reader takes only folders with ``crops.csv``.
"""
