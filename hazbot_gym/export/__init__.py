"""Export of policies for other runtimes: ONNX, and C99 for a microcontroller.

- ``plan``: what an export computes, and which policies have none
- ``onnx_file``: the ONNX graph; ``c_code``: the C files, from ``templates``
- ``golden``: golden vectors; ``check``: exports run beside the policy in Python
- ``write``: the files of an export
"""
