"""The presets that ship: ``default`` measures best, ``realtime`` finds new signs later, ``paper`` follows the text.

A preset is a list of departures from the parameters' defaults; ``default`` is therefore empty.
"""

from __future__ import annotations

from types import MappingProxyType

PRESETS: MappingProxyType[str, MappingProxyType[str, object]] = MappingProxyType(
    {
        "default": MappingProxyType({}),
        "realtime": MappingProxyType({"scan_turns": 3}),
        "paper": MappingProxyType(
            {
                "inset_width": 1.0,
                "inset_height": 1.0,
                "inset_rise": 0.0,
                "motion": "paper",
                "noise_centre": 0.07,
                "noise_size": 0.14,
                "noise_score": 0.0,
                "result_noise": 1.0,
                "open_edges": False,
                "birth_score": 0.0,
                "confirm_score": 0.0,
                "sure_score": None,
                "use_camera_shift": False,
                "level_frames": 0,
                "fusion_mode": "scale",
                "fusion_delta": 20.0,
                "search_scales": (1.0,),
                "search_penalty": 0.0,
                "search_subpixel": False,
                "background_negatives": 0,
                "learn_rejected": True,
                "hash_memory": None,
                "position_unit": "px",
                "position_camera": False,
                "rejected_measurement": "relocalised",
                "relocalise_after": None,
                "rescore_windows": False,
                "search_sigmas": None,
                "learn_undetected": True,
                "reader": "classifier",
            }
        ),
    }
)
