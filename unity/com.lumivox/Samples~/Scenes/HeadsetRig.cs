using System.Collections.Generic;
using UnityEngine;
using UnityEngine.XR;

namespace Lumivox.Samples
{
    /// <summary>
    /// The head in a headset: grip with one hand to move it, with two to scale it, pull the trigger to cut it where the
    /// controller points. Without a headset the camera circles as in the other samples.
    /// </summary>
    [AddComponentMenu("Lumivox/Samples/Headset Rig")]
    public sealed class HeadsetRig : SampleScene
    {
        [Tooltip("Floor to eyes where the headset tells no height, in metres.")] public float eyeHeight = 1.2f;

        const float Pressed = 0.6f, SmallestScale = 0.25f, LargestScale = 6;
        LumivoxVolume head;
        Transform left, right;
        readonly List<Transform> holding = new List<Transform>(), now = new List<Transform>();
        Matrix4x4 held;

        protected override (Vector3 pivot, float distance) Framing => (new Vector3(0, eyeHeight, 0), 0.7f);

        protected override void Build()
        {
            head = Volume("Head", new Vector3(0, eyeHeight, 0), "ct-muscle");
            left = Hand("Left");
            right = Hand("Right");
        }

        Transform Hand(string hand) => Shape(PrimitiveType.Cube, Vector3.zero, 0.03f, Color.grey).transform;

        void Update()
        {
            var worn = InputDevices.GetDeviceAtXRNode(XRNode.CenterEye);
            View.enabled = !worn.isValid;
            left.gameObject.SetActive(worn.isValid);
            right.gameObject.SetActive(worn.isValid);
            if (!worn.isValid) return;
            Follow(worn, View.transform, CommonUsages.centerEyePosition, CommonUsages.centerEyeRotation);
            now.Clear();
            Use(XRNode.LeftHand, left);
            Use(XRNode.RightHand, right);
            Hold();
        }

        void Follow(InputDevice device, Transform what, InputFeatureUsage<Vector3> position, InputFeatureUsage<Quaternion> rotation)
        {
            if (device.TryGetFeatureValue(position, out var place)) what.localPosition = place;
            if (device.TryGetFeatureValue(rotation, out var turn)) what.localRotation = turn;
        }

        void Use(XRNode node, Transform hand)
        {
            var device = InputDevices.GetDeviceAtXRNode(node);
            if (!device.isValid) return;
            Follow(device, hand, CommonUsages.devicePosition, CommonUsages.deviceRotation);
            if (device.TryGetFeatureValue(CommonUsages.grip, out var grip) && grip > Pressed) now.Add(hand);
            if (device.TryGetFeatureValue(CommonUsages.trigger, out var trigger) && trigger > Pressed) Cut(hand);
            if (device.TryGetFeatureValue(CommonUsages.primaryButton, out var whole) && whole) (head.clipMin, head.clipMax) = (Vector3.zero, Vector3.one);
        }

        void Hold()
        {
            var isSame = now.Count == holding.Count && now.TrueForAll(holding.Contains);
            if (!isSame)
            {
                holding.Clear();
                holding.AddRange(now);
                if (holding.Count > 0) held = Grip().inverse * head.transform.localToWorldMatrix;
            }
            else if (holding.Count > 0)
            {
                var place = Grip() * held;
                head.transform.SetPositionAndRotation(place.GetColumn(3), place.rotation);
                head.transform.localScale = Vector3.one * Mathf.Clamp(place.lossyScale.x, SmallestScale, LargestScale);
            }
        }

        /// One hand's frame, or one that spans both: its scale is their distance.
        Matrix4x4 Grip()
        {
            if (holding.Count == 1) return Matrix4x4.TRS(holding[0].position, holding[0].rotation, Vector3.one);
            Vector3 a = holding[0].position, b = holding[1].position;
            var length = Mathf.Max((b - a).magnitude, 0.01f);
            return Matrix4x4.TRS((a + b) / 2, Quaternion.LookRotation(b - a, holding[0].up + holding[1].up), Vector3.one * length);
        }

        /// Moves the face of the clip box that the hand points at to where it is.
        void Cut(Transform hand)
        {
            var toClip = (head.transform.localToWorldMatrix * head.clipTransform).inverse;
            var at = toClip.MultiplyPoint3x4(hand.position);
            var pointing = toClip.MultiplyVector(hand.forward);
            var axis = 0;
            for (var i = 1; i < 3; i++)
                if (Mathf.Abs(pointing[i]) > Mathf.Abs(pointing[axis])) axis = i;
            Vector3 low = head.clipMin, high = head.clipMax;
            if (pointing[axis] > 0) low[axis] = Mathf.Clamp(at[axis], 0, high[axis] - 0.01f);
            else high[axis] = Mathf.Clamp(at[axis], low[axis] + 0.01f, 1);
            (head.clipMin, head.clipMax) = (low, high);
        }
    }
}
