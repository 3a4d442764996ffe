using UnityEngine;

namespace Lumivox
{
    // Where its scan lies in the patient.
    public sealed partial class LumivoxVolume
    {
        /// <summary>
        /// From the patient's millimetres, as DICOM has them (x to the left, y to the back, z to the head), to the object's
        /// metres. The identity without a scan, and before a phantom was computed.
        /// </summary>
        public Matrix4x4 patientTransform => m_Volume != null ? m_Volume.objectFromPatient : Matrix4x4.identity;

        /// <summary>
        /// Moves, turns and scales the object so that its scan lies in <paramref name="other"/>'s as it does in the patient: a
        /// PET in its CT, an MR on a CT. Both must be of one frame of reference. A scan's centre is at its object's origin, so
        /// that two objects in one place are not aligned yet. Returns whether both have a scan, and it is known where they lie:
        /// phantoms say so once they were computed.
        /// </summary>
        /// <remarks>Below a parent that is scaled unevenly and turned against the other, an object cannot stand as the other does.</remarks>
        public bool AlignWith(LumivoxVolume other)
        {
            MainThread.Need("LumivoxVolume.AlignWith");
            if (other == null || other == this || !HasPlace(this) || !HasPlace(other)) return false;
            // Scans stand alike in their objects, but for where their centres are.
            Vector3 shift = other.patientTransform.GetColumn(3) - patientTransform.GetColumn(3);
            var (mine, theirs) = (transform, other.transform);
            if (mine.parent == theirs.parent)
            {
                mine.localRotation = theirs.localRotation;
                mine.localScale = theirs.localScale;
            }
            else
            {
                mine.rotation = theirs.rotation;
                mine.localScale = Vector3.one;
                var (wanted, one) = (theirs.lossyScale, mine.lossyScale);
                mine.localScale = new Vector3(Ratio(wanted.x, one.x), Ratio(wanted.y, one.y), Ratio(wanted.z, one.z));
            }
            mine.position = theirs.TransformPoint(shift);
            return true;
        }

        static bool HasPlace(LumivoxVolume volume) => volume.m_Volume != null && volume.m_Volume.IsPlaceKnown;

        /// Below a parent without extent nothing helps.
        static float Ratio(float wanted, float one) => one != 0f ? wanted / one : 1f;
    }
}
