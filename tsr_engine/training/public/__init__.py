"""Trains each component on public data; :mod:`.train_parts` trains a whole version.

=========================  ===============================================================================
``detector``, ``prior``    :mod:`.detector_components`: split, figures and calibration around :mod:`.detector`,
                           which trains cascade, refine-and-verify stage, sign verifier and box refinement
``other_shapes``           :mod:`.other_shapes`: the same parts for signs outside the 43 classes
``classifier``             :mod:`.classifier`: gradient descent in NumPy (:mod:`.classifier_network`)
``network_classifier``     :mod:`.network_classifier`: the network that PyTorch trains (:mod:`.network`)
``online``                 :mod:`.online_samples`
``memory``                 :mod:`.memory`: samples for later refinements
=========================  ===============================================================================
"""
