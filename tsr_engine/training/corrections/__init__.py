"""Refines a model version with corrections: :mod:`.retrain`.

Exports are opened (:mod:`.exports`), their labels mapped to the model's classes (:mod:`.class_mapping`) and their
tracks turned into scenes (:mod:`.corrected_scenes`). A ``refine_`` module each trains one component further;
:mod:`.holdout` compares the versions.
"""
