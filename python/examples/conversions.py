"""From SimpleITK to Lumivox and back to nibabel: the same voxels at the same place in the patient."""

import numpy as np
import SimpleITK as sitk

import lumivox

image = sitk.GetImageFromArray(np.arange(120, dtype=np.int16).reshape(4, 5, 6) * 10)
image.SetSpacing((0.8, 0.8, 2.0))
image.SetOrigin((-100.0, -80.0, 40.0))
smooth = sitk.SmoothingRecursiveGaussian(image, 1.0)

volume = lumivox.Volume.from_sitk(smooth, modality="MR")
nifti = volume.to_nibabel()
# LPS there, RAS here.
here = nifti.affine @ [1, 2, 1, 1]
there = np.array(image.TransformIndexToPhysicalPoint((1, 2, 1)))
assert np.allclose(here[:3], there * [-1, -1, 1])
print(volume, nifti.shape)
